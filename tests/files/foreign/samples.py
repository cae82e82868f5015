"""Small files of other systems, written as their standards show them, with numbers made up."""

from __future__ import annotations

QIF = """<?xml version="1.0" encoding="UTF-8"?>
<QIFDocument xmlns="http://qifstandards.org/xsd/qif3" idMax="40" versionQIF="3.0.0">
<FileUnits><PrimaryUnits>
<AngularUnit><SIUnitName>radian</SIUnitName><UnitName>degree</UnitName><UnitConversion><Factor>0.017453292519943295</Factor></UnitConversion></AngularUnit>
<LinearUnit><SIUnitName>meter</SIUnitName><UnitName>inch</UnitName><UnitConversion><Factor>0.0254</Factor></UnitConversion></LinearUnit>
</PrimaryUnits></FileUnits>
<DatumDefinitions n="1"><DatumDefinition id="1"><DatumLabel>A</DatumLabel><FeatureNominalIds n="1"><Id>3</Id></FeatureNominalIds></DatumDefinition></DatumDefinitions>
<DatumReferenceFrames n="1"><DatumReferenceFrame id="10"><Datums n="1"><Datum><SimpleDatum><DatumDefinitionId>1</DatumDefinitionId><MaterialModifier>NONE</MaterialModifier></SimpleDatum><Precedence><PrecedenceEnum>PRIMARY</PrecedenceEnum></Precedence></Datum></Datums></DatumReferenceFrame></DatumReferenceFrames>
<Features>
<FeatureDefinitions n="2"><PlaneFeatureDefinition id="2"/><CylinderFeatureDefinition id="5"><InternalExternal>INTERNAL</InternalExternal><Diameter>1</Diameter><Length>2</Length></CylinderFeatureDefinition></FeatureDefinitions>
<FeatureNominals n="2">
<PlaneFeatureNominal id="3"><FeatureDefinitionId>2</FeatureDefinitionId><Location>0 0 2</Location><Normal>0 0 1</Normal></PlaneFeatureNominal>
<CylinderFeatureNominal id="6"><FeatureDefinitionId>5</FeatureDefinitionId><Axis><AxisPoint>0 0 0</AxisPoint><Direction>0 0 1</Direction></Axis></CylinderFeatureNominal>
</FeatureNominals>
<FeatureItems n="2">
<PlaneFeatureItem id="4"><FeatureNominalId>3</FeatureNominalId><FeatureName>top</FeatureName></PlaneFeatureItem>
<CylinderFeatureItem id="7"><FeatureNominalId>6</FeatureNominalId><FeatureName>bore</FeatureName></CylinderFeatureItem>
</FeatureItems>
</Features>
<Characteristics>
<CharacteristicDefinitions n="3">
<DiameterCharacteristicDefinition id="20"><Tolerance><MaxValue>1.001</MaxValue><MinValue>0.999</MinValue><DefinedAsLimit>true</DefinedAsLimit></Tolerance></DiameterCharacteristicDefinition>
<PerpendicularityCharacteristicDefinition id="23"><ToleranceValue>0.002</ToleranceValue><DatumReferenceFrameId>10</DatumReferenceFrameId><MaterialCondition>MAXIMUM</MaterialCondition></PerpendicularityCharacteristicDefinition>
<LinearCoordinateCharacteristicDefinition id="26"><NonTolerance>MEASURED</NonTolerance></LinearCoordinateCharacteristicDefinition>
</CharacteristicDefinitions>
<CharacteristicNominals n="3">
<DiameterCharacteristicNominal id="21"><CharacteristicDefinitionId>20</CharacteristicDefinitionId></DiameterCharacteristicNominal>
<PerpendicularityCharacteristicNominal id="24"><CharacteristicDefinitionId>23</CharacteristicDefinitionId></PerpendicularityCharacteristicNominal>
<LinearCoordinateCharacteristicNominal id="27"><CharacteristicDefinitionId>26</CharacteristicDefinitionId></LinearCoordinateCharacteristicNominal>
</CharacteristicNominals>
<CharacteristicItems n="3">
<DiameterCharacteristicItem id="22"><Name>D1</Name><FeatureItemIds n="1"><Id>7</Id></FeatureItemIds><CharacteristicNominalId>21</CharacteristicNominalId></DiameterCharacteristicItem>
<PerpendicularityCharacteristicItem id="25"><Name>P1</Name><FeatureItemIds n="1"><Id>7</Id></FeatureItemIds><CharacteristicNominalId>24</CharacteristicNominalId></PerpendicularityCharacteristicItem>
<LinearCoordinateCharacteristicItem id="28"><Name>X1</Name><FeatureItemIds n="1"><Id>7</Id></FeatureItemIds><CharacteristicNominalId>27</CharacteristicNominalId></LinearCoordinateCharacteristicItem>
</CharacteristicItems>
</Characteristics>
</QIFDocument>
"""

DMIS = """DMISMN/'bracket',05.2
$$ a comment
UNITS/MM,ANGDEC
MODE/PROG,MAN
F(TOP)=FEAT/PLANE,CART,0,0,20,0,0,1
F(BORE)=FEAT/CYLNDR,INNER,CART,0,0,0,0,0,1,30,20
F(HOLE)=FEAT/CIRCLE,INNER,CART,25,$
25,20,0,0,1,8
F(TAPER)=FEAT/CONE,OUTER,CART,0,0,100,0,0,-1,90
T(DIA)=TOL/DIAM,-0.010,0.021
T(PP)=TOL/PERP,0.01,RFS,DAT(A)
T(POS1)=TOL/POS,2D,0.1,MMC,DAT(A),RFS,DAT(B),RFS
T(DI)=TOL/DISTB,NOMINL,35.3553,-0.05,0.05,PT2PT
T(UNUSED)=TOL/FLAT,0.1
MEAS/PLANE,F(TOP),4
PTMEAS/CART,-30,-20,20,0,0,1
PTMEAS/CART,30,-20,20,0,0,1
PTMEAS/CART,30,20,20,0,0,1
PTMEAS/CART,-30,20,20,0,0,1
ENDMES
MEAS/CONE,F(TAPER),2
PTMEAS/CART,10,0,90,0.7071067811865476,0,0.7071067811865476
PTMEAS/CART,0,30,70,0,0.7071067811865476,0.7071067811865476
ENDMES
DATDEF/FA(TOP),DAT(A)
DATDEF/FA(BORE),DAT(B)
OUTPUT/FA(BORE),TA(DIA),TA(PP)
OUTPUT/FA(HOLE),TA(POS1),TA(DIA)
OUTPUT/FA(HOLE),FA(BORE),TA(DI)
ENDFIL
"""

DCC = r"""<?xml version="1.0" encoding="UTF-8"?>
<dcc:digitalCalibrationCertificate xmlns:dcc="https://ptb.de/dcc" xmlns:si="https://ptb.de/si" schemaVersion="3.3.0">
<dcc:measurementResults><dcc:measurementResult><dcc:results><dcc:result>
<dcc:name><dcc:content lang="de">Ring</dcc:content><dcc:content lang="en">ring gauge</dcc:content></dcc:name>
<dcc:data>
<dcc:quantity><dcc:name><dcc:content>diameter</dcc:content></dcc:name><si:real><si:value>0.0500012</si:value><si:unit>\metre</si:unit>
<si:measurementUncertaintyUnivariate><si:expandedMU><si:valueExpandedMU>2.4e-7</si:valueExpandedMU><si:coverageFactor>2</si:coverageFactor><si:coverageProbability>0.95</si:coverageProbability></si:expandedMU></si:measurementUncertaintyUnivariate></si:real></dcc:quantity>
<dcc:quantity><dcc:name><dcc:content>deviation</dcc:content></dcc:name><si:realListXMLList><si:valueXMLList>0.1 0.3</si:valueXMLList><si:unitXMLList>\micro\metre</si:unitXMLList>
<si:expandedUncXMLList><si:uncertaintyXMLList>0.2</si:uncertaintyXMLList><si:coverageFactorXMLList>2</si:coverageFactorXMLList></si:expandedUncXMLList></si:realListXMLList></dcc:quantity>
</dcc:data></dcc:result></dcc:results></dcc:measurementResult></dcc:measurementResults>
</dcc:digitalCalibrationCertificate>
"""
